/* tree_data.h - state and work arrays of trees in joint coordinates; other rooms access them through the functions of tree.h. */
#ifndef JO_TREE_DATA_H
#define JO_TREE_DATA_H

#include "small.h"

typedef struct jo_link_work jo_link_work;
typedef struct jo_link_constants jo_link_constants;
typedef struct jo_link_response jo_link_response;
typedef struct jo_link_coupling jo_link_coupling;
typedef struct jo_loop_work jo_loop_work;
typedef struct jo_reach_work jo_reach_work;

/* A dense symmetric matrix S of n rows and its factors, see dense_cholesky.c. */
typedef struct {
    int n, ld, rank;        /* columns in memory; number of independent rows */
    jo_real *S, *inverse, *y;   /* (n x ld), (n) of the pivots, (n) scratch */
    double *scale;          /* (n) scales of the diagonal: a row with a pivot far below its scale depends on others */
    int *order;             /* (n) rows in elimination order */
} jo_gram;

/* Trees in joint coordinates, see tree.c. While a model runs in them, x and u are the state; q, v, a and lam are updated on demand. */
typedef struct {
    jo_real *tau;           /* (nu) force along each joint coordinate, N or N m */
    jo_real *stiffness, *damping;   /* (nu) stiffness and damping along joint coordinates in the matrix of a Rosenbrock method */
    jo_link_coupling *coupling;   /* (nlink) gear springs in the matrix of a Rosenbrock method */
    int coupled;            /* whether the factors of the last evaluation contain them */
    jo_real *drive_force;   /* (nlink) force of the drive of each link, N or N m */
    jo_link_work *link;     /* (nlink + 1), the ground first */
    jo_link_constants *constants;   /* (nlink) */
    jo_link_response *response;   /* (nlink + 1) response to added forces */
    jo_real *joint_response;   /* (nu) response of the joints to added forces */
    jo_real *added_tau;     /* (nu) added forces along the joint coordinates, N or N m */
    jo_real *contact_jacobian, *contact_response, *contact_factors, *contact_force;   /* (n x nu) twice, (n x n), (n) of tree_contacts.c, n: three a contact */
    int *contact_pivot, contact_rows;   /* (n) row exchanges; rows of the contacts that are closed */
    int *marker, *coordinate, *body;   /* markers, coordinates and bodies that force laws read at every evaluation */
    int nmarker, ncoordinate, nbody;
    int *hinge, nhinge;     /* links with a hinge */
    int *of_body;           /* (nbody) link of a body; -1: none. Only if the model has links */
    int ndriven;            /* number of links with a drive */
    jo_real *maximal_copy;  /* (nq + nv) q and v computed from x and u, for comparison */
    int counts_joint_angles;   /* whether all counted angles are joint coordinates */
    jo_loop_work *loop;     /* (nloop) */
    jo_reach_work *reach;   /* (nreach) */
    jo_gram *gram;          /* (ngroup) Schur complements J H^-1 J^T, one for each group of coupled loops */
    int ngroup;
    int *loop_marker, nloop_marker;   /* markers of the joints that close loops */
} jo_tree;

#endif
