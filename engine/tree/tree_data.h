/* tree_data.h - what the files of this room keep; other rooms reach it by the functions of tree.h. */
#ifndef JO_TREE_DATA_H
#define JO_TREE_DATA_H

#include "maximal/maximal_data.h"

/* Rigid trees in joint coordinates, see tree.c. While `on` the state is x and u; q and v, then also a and lam, follow when somebody
 * needs them. */
typedef struct jo_link_work jo_link_work;
typedef struct jo_link_constants jo_link_constants;
typedef struct jo_link_change jo_link_change;
typedef enum { JO_MIRROR_NONE = 0, JO_MIRROR_PART = 1,   /* PART: the bodies that run by rows, with their markers */
               JO_MIRROR_STATE = 2, JO_MIRROR_ALL = 3 } jo_mirrored;
typedef struct jo_loop_work jo_loop_work;
typedef struct jo_reach_work jo_reach_work;

typedef struct {
    int on;
    jo_mirrored mirrored;
    int summed;             /* the links have all accelerations and loads of the last evaluation */
    jo_real *x, *u, *ud;    /* (nx), (nu) coordinates, rates, accelerations */
    jo_real *tau;           /* (nu) force along each of them */
    jo_real *stiffness, *damping;   /* (nu) that are implicit in ROS2 */
    jo_real *pull;          /* (nlink) force of each drive */
    jo_link_work *link;     /* (nlink + 1), the ground first */
    jo_link_constants *constants;   /* (nlink) */
    jo_link_change *change; /* (nlink + 1) by further forces */
    jo_real *push;          /* (nu) further forces along the coordinates */
    int *marker, *coordinate, *body;   /* that forces need at every evaluation */
    int nmarker, ncoordinate, nbody;
    int *hinge, nhinge;     /* links that are hinges */
    int ndriven;            /* links whose motion is prescribed by a drive */
    jo_real *seen;          /* (nq + nv) what q and v are by x and u */
    int direct;             /* all counted angles are joint coordinates */
    jo_loop_work *loop;     /* (nloop) */
    jo_reach_work *reach;   /* (nreach) */
    jo_gram *gram;          /* (ngroup) */
    int ngroup;
    int *closing, nclosing; /* markers of the loops */
    int kept;               /* bodies that run by the rows of their joints, the first links; 0: the links have all */
    int narrow;             /* the core in q and v works on these alone */
    int *away_body, *away_marker, *away_coordinate, *away_joint;   /* what it leaves out then */
    int column, pair, fill; /* where its columns and fills begin and its pairs end */
} jo_tree;

#endif
