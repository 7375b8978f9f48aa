/* valid.h - validity of computed quantities, its transitions, and the split of a model between the two solvers.
 *
 * bit             guards                                                set by                          cleared by
 * --------------  ----------------------------------------------------  ------------------------------  ------------------------------------
 * kinematics      pose and motion of bodies and active markers          jo_kinematics_placed            jo_state_changed, jo_kinematics_used
 *                 at q, v                                               jo_state_projected              jo_call_begins, jo_step_repeated
 * accelerations   a, lam and power at time, q, v, without the modal     jo_accelerations_found          jo_state_changed, jo_call_begins
 *                 masses of a Rosenbrock method                         jo_step_repeated                jo_state_projected, jo_forces_break
 * before_call     accelerations, before the caller could change         jo_call_begins                  jo_first_stage_done
 *                 the state
 * stage           a and power of a stage of Dormand-Prince at the       jo_stage_recalled               jo_stage_forgotten, jo_state_read
 *                 present state, whose bodies stand elsewhere                                           jo_control_begins
 * damage          counts of the damage meters at the present state      jo_damage_counted               jo_damage_outdated, jo_control_begins
 * jump            a jump of the forces that generalised alpha has       jo_forces_jumped                jo_history_begins
 *                 not yet answered with a new start                     jo_history_forgotten            jo_step_repeated
 * history         algorithmic and true accelerations of generalised     jo_history_written              jo_history_begins
 *                 alpha at the end of its last step                     jo_step_repeated                jo_history_lost
 * levels          values and sides of events and frictions              jo_levels_measured              jo_history_forgotten
 * grid            instants of jo_run of its last call                   jo_grid_left                    jo_history_forgotten
 * newton_factors  factors in Newton's matrix, of its last weights       jo_newton_factored              jo_newton_outdated, jo_history_begins
 *                                                                                                       jo_history_lost
 * newton_soft     these are regularised by `soft`                       jo_newton_softened              jo_newton_softened
 * schur_soft      the factors of S are regularised                      jo_schur_softened               jo_schur_softened
 * tree            x and u are the state, q and v follow                 jo_tree_chosen, jo_detour_ends  jo_tree_chosen, jo_detour_begins
 * hybrid          hybrid mode: the solver in maximal coordinates works  jo_hybrid_begins                jo_hybrid_ends
 *                 on the bodies outside the trees only
 * joint_forces    total accelerations of the links and forces of their  jo_joint_forces_summed          jo_joint_forces_outdated
 *                 joints, of the last evaluation
 * sync            how much of q, v, a and lam agrees with x and u       jo_sync_reached                 jo_positions_moved, jo_step_repeated
 *
 * No other file reads or writes a bit.
 */
#ifndef JO_VALID_H
#define JO_VALID_H

#include "arena.h"
#include "data.h"

/* split.c */
void jo_split_layout(const jo_model *m, jo_data *d, jo_arena *a);
void jo_split_setup(const jo_model *m, jo_data *d);

/* ---- the state, its kinematics and accelerations ------------------------------------------------- */

/* initial state: no quantity is valid */
static inline void jo_nothing_valid(jo_data *d) { d->valid = (jo_valid){.jump = 1}; }

/* change of time, q, v or of the forces */
static inline void jo_state_changed(jo_data *d) { d->valid.accelerations = d->valid.kinematics = 0; }

/* kinematics of bodies and markers belong to q, v; set only if accelerations are invalid, since otherwise no evaluation would clear the
 * bit */
static inline void jo_kinematics_placed(jo_data *d) { d->valid.kinematics = !d->valid.accelerations; }

/* kinematics consumed by an evaluation, or outdated by a change of positions */
static inline void jo_kinematics_used(jo_data *d) { d->valid.kinematics = 0; }

static inline void jo_accelerations_found(jo_data *d, int found) { d->valid.accelerations = found; }

/* q and v were projected together with the kinematics of the bodies; in hybrid mode without those of the links */
static inline void jo_state_projected(jo_data *d)
{
    d->valid.accelerations = 0;
    d->valid.kinematics = !d->valid.hybrid;
}

/* change of the forces at the same time, q, v */
static inline void jo_forces_break(jo_data *d) { d->valid.accelerations = 0; }

static inline int jo_kinematics_valid(const jo_data *d) { return d->valid.kinematics; }
static inline int jo_accelerations_valid(const jo_data *d) { return d->valid.accelerations; }

/* ---- calls of the user, stages, damage meters ------------------------------------------------------ */

/* start of a call: the caller may have changed the state */
static inline void jo_call_begins(jo_data *d)
{
    d->valid.before_call = d->valid.accelerations;
    jo_state_changed(d);
}
static inline void jo_first_stage_done(jo_data *d) { d->valid.before_call = 0; }
static inline int jo_valid_before_call(const jo_data *d) { return d->valid.before_call; }

/* a and power of a stored stage belong to the present state; the kinematics do not */
static inline void jo_stage_recalled(jo_data *d, int known)
{
    jo_state_changed(d);
    d->valid.stage = known;
}
static inline void jo_stage_forgotten(jo_data *d) { d->valid.stage = 0; }

/* whether a and power belong to the present state, with or without the kinematics */
static inline int jo_accelerations_known(const jo_data *d) { return d->valid.accelerations || d->valid.stage; }

static inline void jo_damage_counted(jo_data *d) { d->valid.damage = 1; }
static inline void jo_damage_outdated(jo_data *d) { d->valid.damage = 0; }
static inline int jo_damage_valid(const jo_data *d) { return d->valid.damage; }

/* start of a run with error control */
static inline void jo_control_begins(jo_data *d)
{
    d->valid.stage = d->valid.damage = 0;
    jo_forces_break(d);
}

/* ---- history of methods and events ------------------------------------------------------------------ */

static inline void jo_forces_jumped(jo_data *d) { d->valid.jump = 1; }

/* replacement of the state by the caller */
static inline void jo_history_forgotten(jo_data *d)
{
    d->valid.jump = 1;
    d->valid.levels = d->valid.grid = 0;
}

/* restart of generalised alpha */
static inline void jo_history_begins(jo_data *d) { d->valid.history = d->valid.newton_factors = d->valid.jump = 0; }
static inline void jo_history_written(jo_data *d) { d->valid.history = 1; }
static inline void jo_history_lost(jo_data *d) { d->valid.history = d->valid.newton_factors = 0; }
static inline int jo_history_valid(const jo_data *d) { return d->valid.history && !d->valid.jump; }

/* return to the start of a step, where the bits were `start` */
static inline jo_valid jo_valid_now(const jo_data *d) { return d->valid; }
static inline void jo_step_repeated(jo_data *d, const jo_valid *start)
{
    d->valid.accelerations = start->accelerations;
    d->valid.jump = start->jump;
    d->valid.history = start->history;
    d->valid.kinematics = 0;
    d->valid.sync = JO_SYNC_NONE;
}

static inline void jo_levels_measured(jo_data *d) { d->valid.levels = 1; }
static inline int jo_levels_valid(const jo_data *d) { return d->valid.levels; }
static inline void jo_grid_left(jo_data *d, int whole) { d->valid.grid = whole; }
static inline int jo_grid_valid(const jo_data *d) { return d->valid.grid; }

/* ---- factors ------------------------------------------------------------------------------------------ */

static inline void jo_newton_factored(jo_data *d, int sound) { d->valid.newton_factors = sound; }
static inline void jo_newton_outdated(jo_data *d) { d->valid.newton_factors = 0; }
static inline int jo_newton_valid(const jo_data *d) { return d->valid.newton_factors; }
static inline void jo_newton_softened(jo_data *d, int soft) { d->valid.newton_soft = soft; }
static inline int jo_newton_soft(const jo_data *d) { return d->valid.newton_soft; }
static inline void jo_schur_softened(jo_data *d, int soft) { d->valid.schur_soft = soft; }
static inline int jo_schur_soft(const jo_data *d) { return d->valid.schur_soft; }

/* ---- joint coordinates -------------------------------------------------------------------------------- */

static inline void jo_tree_chosen(jo_data *d, int tree) { d->valid.tree = tree; }

/* joint coordinates were computed from q and v */
static inline void jo_state_read(jo_data *d) { d->valid.accelerations = d->valid.stage = 0; }

/* change of x and u */
static inline void jo_positions_moved(jo_data *d) { d->valid.sync = JO_SYNC_NONE; }
static inline void jo_sync_reached(jo_data *d, jo_sync_level how) { d->valid.sync = how; }
static inline int jo_sync_valid(const jo_data *d, jo_sync_level how) { return d->valid.sync >= how; }
static inline int jo_sync_is_hybrid(const jo_data *d) { return d->valid.sync == JO_SYNC_HYBRID; }

static inline void jo_joint_forces_outdated(jo_data *d) { d->valid.joint_forces = 0; }
static inline void jo_joint_forces_summed(jo_data *d) { d->valid.joint_forces = 1; }
static inline int jo_joint_forces_valid(const jo_data *d) { return d->valid.joint_forces; }

static inline void jo_hybrid_begins(jo_data *d) { d->valid.hybrid = d->valid.tree; }
static inline void jo_hybrid_ends(jo_data *d) { d->valid.hybrid = 0; }

/* evaluation in maximal coordinates of a state in joint coordinates; returns the bits to be restored */
static inline jo_valid jo_detour_begins(jo_data *d)
{
    const jo_valid before = d->valid;
    d->valid.kinematics = d->valid.tree = 0;
    return before;
}
static inline void jo_detour_ends(jo_data *d, const jo_valid *before)
{
    d->valid.tree = 1;
    d->valid.kinematics = before->kinematics;
}

/* ---- split between the solvers -------------------------------------------------------------------------- */

static inline int jo_tree_active(const jo_data *d) { return d->valid.tree; }
static inline int jo_in_hybrid(const jo_data *d) { return d->valid.hybrid; }

/* number of bodies in maximal coordinates, which are the first links; 0: all bodies are in the tree */
static inline int jo_nmaximal(const jo_data *d) { return d->split.nmaximal; }

/* whether a body, marker, coordinate or joint is in the trees */
static inline int jo_body_in_tree(const jo_data *d, int i) { return d->split.body[i]; }
static inline int jo_marker_in_tree(const jo_data *d, int i) { return d->split.marker[i]; }
static inline int jo_coordinate_in_tree(const jo_data *d, int i) { return d->split.coordinate[i]; }
static inline int jo_joint_in_tree(const jo_data *d, int i) { return d->split.joint[i]; }

/* whether the maximal-coordinate solver skips an item; in hybrid mode it skips the items in trees */
static inline int jo_body_inactive(const jo_data *d, int i) { return d->valid.hybrid && d->split.body[i]; }
static inline int jo_marker_inactive(const jo_data *d, int i) { return d->valid.hybrid && d->split.marker[i]; }
static inline int jo_coordinate_inactive(const jo_data *d, int i) { return d->valid.hybrid && d->split.coordinate[i]; }
static inline int jo_joint_inactive(const jo_data *d, int i) { return d->valid.hybrid && d->split.joint[i]; }

#endif
