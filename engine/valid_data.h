/* valid_data.h - validity bits of computed quantities, accessed through the functions of valid.h only. */
#ifndef JO_VALID_DATA_H
#define JO_VALID_DATA_H

/* Which of the maximal coordinates agree with the joint coordinates x, u: none; the bodies of hybrid mode and their markers; q and v; q, v,
 * accelerations a and multipliers lam. */
typedef enum { JO_SYNC_NONE = 0, JO_SYNC_HYBRID = 1, JO_SYNC_STATE = 2, JO_SYNC_ALL = 3 } jo_sync_level;

/* Validity bits, see the table in valid.h. */
typedef struct {
    int kinematics, accelerations, before_call, stage, damage;
    int jump, history, levels, grid;
    int newton_factors, newton_soft, schur_soft;
    int tree, hybrid, joint_forces;
    jo_sync_level sync;
} jo_valid;

/* Split of a model between the solvers: constant, see split.c. */
typedef struct {
    int nmaximal;           /* number of bodies in maximal coordinates, which are the first links; 0: all bodies are in the tree */
    int *body, *marker, *coordinate, *joint;   /* (each count) whether an item is in the trees */
} jo_split;

#endif
