/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * ry_state: exactly what a checkpoint holds. Everything else of a simulation is rebuilt from it and
 * the config (ry_plan). Arrays of grains are structures of arrays in storage order, which may be any
 * permutation of the ids; files and hashes always use id order. */
#ifndef RY_STORE_STATE_H
#define RY_STORE_STATE_H

#include <stdint.h>

#include "base/exact.h"
#include "ryusa/status.h"

/* Most walls a scene has: the floor, the left and the right one. */
enum { RY_MAX_WALLS = 3 };

/* The grains. Entries n .. n + RY_MAX_WALLS - 1 of the arrays are the walls: partners at rest with
 * radius and inverse mass 0, so that a kernel needs no case for them.
 *
 * RY_GRAIN_FIELD(type, name, unit, text), the arrays that are state: */
#define RY_GRAIN_FIELDS(RY_GRAIN_FIELD)                                                            \
    RY_GRAIN_FIELD(double, x, "m", "centre along the bed, within [0, length) where x is periodic") \
    RY_GRAIN_FIELD(double, z, "m", "centre above the floor")                                       \
    RY_GRAIN_FIELD(double, vx, "m/s", "velocity along x")                                          \
    RY_GRAIN_FIELD(double, vz, "m/s", "velocity along z")                                          \
    RY_GRAIN_FIELD(double, spin, "rad/s", "angular velocity about y, positive from z towards x")   \
    RY_GRAIN_FIELD(double, radius, "m", "radius")                                                  \
    RY_GRAIN_FIELD(double, density, "kg/m^3", "density")                                           \
    RY_GRAIN_FIELD(double, push, "N", "model stress: shear force on an exposed grain; model balance: "       \
                   "sum of the fluid's forces along x over the steps since the last advance") \
    RY_GRAIN_FIELD(double, met, "1", "fluid.turbulence: 1 + the step at which it met its eddy; 0: none yet") \
    RY_GRAIN_FIELD(int32_t, image, "1", "how often x was wrapped: unwrapped x = x + image * length") \
    RY_GRAIN_FIELD(int32_t, id, "1", "0 .. n-1, never changes")                                    \
    RY_GRAIN_FIELD(uint8_t, fixed, "1", "1: nothing moves it")

typedef struct ry_grains {
    int32_t n; /* grains, fixed ones included. push, met: NULL where the fluid has no use for them, which counts as 0 */
#define RY_GRAIN_POINTER(type, name, unit, text) type *name;
    RY_GRAIN_FIELDS(RY_GRAIN_POINTER)
#undef RY_GRAIN_POINTER
} ry_grains;

/* A number of steps up to 255; hashes like a double. */
typedef uint8_t ry_steps;

/* The memory of contacts, sorted by (id_i, id_j), id_i < id_j; a wall w is the partner id n + w.
 * Only contacts that touch have an entry. This is the form in which it is saved and compared; while
 * a simulation runs the live values stand in ry_pairs and are collected by ry_pairs_export.
 * RY_CONTACT_FIELD(type, name, unit, text) */
#define RY_CONTACT_FIELDS(RY_CONTACT_FIELD)                                                     \
    RY_CONTACT_FIELD(int32_t, id_i, "1", "lower id")                                            \
    RY_CONTACT_FIELD(int32_t, id_j, "1", "higher id; n + w for wall w")                         \
    RY_CONTACT_FIELD(double, slip, "m", "stretch of the tangential spring; law energy, in an impact (age 1 to 4): " \
                     "p, what it adds to the approach of a step, less gravity's part")          \
    RY_CONTACT_FIELD(double, rest, "m", "overlap at which the normal spring is relaxed; in an impact with p other " \
                     "than 0: E [m^2], its spring holds E - p w/2, w the approach of the last step, per m_r/dt^2") \
    RY_CONTACT_FIELD(ry_steps, age, "1", "steps since the contact closed, up to 255; law energy: 5 to 254 from the step on in which it " \
                     "became enduring, 255: enduring, but has not pushed yet")

/* Those with contact.wet only. */
#define RY_WET_FIELDS(RY_CONTACT_FIELD)                                                         \
    RY_CONTACT_FIELD(double, wet, "1", "restitution that the fluid has left, of laws that take one; else what " \
                     "it has made of the dashpot, twice the damping ratio (Hertz: sqrt 5 times)")

/* Those of two grains that sleep, with contact.sleep only; 0 for all others. */
#define RY_FROZEN_FIELDS(RY_CONTACT_FIELD)                                                      \
    RY_CONTACT_FIELD(double, frozen_x, "N s", "impulse of a step on the owner along x, when both were last awake") \
    RY_CONTACT_FIELD(double, frozen_z, "N s", "and along z")                                    \
    RY_CONTACT_FIELD(double, frozen_turn, "N s", "and its angular impulse per radius")

typedef struct ry_contacts {
    int64_t n, capacity;
    int64_t no_rest; /* 1: rest is NULL and counts as 0: of laws that have none */
    int64_t is_wet; /* 1: has RY_WET_FIELDS; else they are NULL */
    int64_t sleeps; /* 1: has RY_FROZEN_FIELDS; else they are NULL */
#define RY_CONTACT_POINTER(type, name, unit, text) type *name;
    RY_CONTACT_FIELDS(RY_CONTACT_POINTER)
    RY_WET_FIELDS(RY_CONTACT_POINTER)
    RY_FROZEN_FIELDS(RY_CONTACT_POINTER)
#undef RY_CONTACT_POINTER
} ry_contacts;

/* The fluid column: cells of equal height, cell k from z = k dz to (k+1) dz. nz = 0: no column.
 * RY_COLUMN_FIELD(name, unit, text), each nz doubles: */
#define RY_COLUMN_FIELDS(RY_COLUMN_FIELD)                                                        \
    RY_COLUMN_FIELD(u, "m/s", "velocity of the fluid")                                           \
    RY_COLUMN_FIELD(phi, "1", "solid fraction, running mean")                                    \
    RY_COLUMN_FIELD(solid, "1", "solid fraction at the last advance: what hinders drag")         \
    RY_COLUMN_FIELD(gradient, "Pa/m", "d tau_f / dz as the grains feel it")                      \
    RY_COLUMN_FIELD(taken, "N/m^3", "what the last advance took from the fluid for the grains")

typedef struct ry_column {
    int32_t nz;
    double dz;        /* [m] */
    double bed_level; /* height at which phi falls to half of the bed's, last advance [m] */
#define RY_COLUMN_POINTER(name, unit, text) double *name;
    RY_COLUMN_FIELDS(RY_COLUMN_POINTER)
#undef RY_COLUMN_POINTER
} ry_column;

/* Running totals of the energy ledger since step 0 [J]. RY_LEDGER_ROW(name, text) */
#define RY_LEDGER_TOTALS(RY_LEDGER_ROW)                                                          \
    RY_LEDGER_ROW(loss_impact, "lost by restitution at impact")                                  \
    RY_LEDGER_ROW(loss_dashpot, "lost by normal and tangential dashpots")                        \
    RY_LEDGER_ROW(loss_friction, "lost by sliding")                                              \
    RY_LEDGER_ROW(loss_opening, "lost with the tangential spring of a contact that opens")       \
    RY_LEDGER_ROW(fluid_work, "work of the fluid on the grains")

/* Exact sums: they do not depend on the order of work. Their scale follows from the scene (ry_plan). */
typedef struct ry_ledger {
    int64_t kept; /* 1: there is a ledger */
#define RY_LEDGER_TOTAL(name, text) ry_exact name;
    RY_LEDGER_TOTALS(RY_LEDGER_TOTAL)
#undef RY_LEDGER_TOTAL
    double energy_start; /* kinetic + gravity + elastic energy at step 0 [J] */
} ry_ledger;

/* Who sleeps (stage/sleep.h), with contact.sleep only; else the arrays are NULL. In storage order, with room for the
 * walls. RY_SLEEP_FIELD(type, name, unit, text) */
#define RY_SLEEP_FIELDS(RY_SLEEP_FIELD)                                                         \
    RY_SLEEP_FIELD(uint8_t, asleep, "1", "1: rests and is skipped; fixed grains always")        \
    RY_SLEEP_FIELD(double, from_x, "m", "where it was at the last look at who rests")           \
    RY_SLEEP_FIELD(double, from_z, "m", "and its height")                                       \
    RY_SLEEP_FIELD(double, load, "N s", "of a sleeper: half the sum of its contacts' impulses of a step, at least its weight's") \
    RY_SLEEP_FIELD(double, bears, "N s", "change of the impulse of a step that wakes it")       \
    RY_SLEEP_FIELD(double, rest_x, "N s", "impulse of its contacts on it in a step, along x, while it rests") \
    RY_SLEEP_FIELD(double, rest_z, "N s", "and along z")                                        \
    RY_SLEEP_FIELD(double, rest_turn, "N s", "and about y, per radius")                         \
    RY_SLEEP_FIELD(double, more_x, "N s", "what they give beyond that, running mean over a natural period, along x") \
    RY_SLEEP_FIELD(double, more_z, "N s", "and along z")                                        \
    RY_SLEEP_FIELD(double, more_turn, "N s", "and about y, per radius")                         \
    RY_SLEEP_FIELD(double, rest_gx, "m/s", "velocity change of a step by the fluid while it rests, along x") \
    RY_SLEEP_FIELD(double, rest_gz, "m/s", "by gravity and fluid, along z")

typedef struct ry_sleepers {
#define RY_SLEEP_POINTER(type, name, unit, text) type *name;
    RY_SLEEP_FIELDS(RY_SLEEP_POINTER)
#undef RY_SLEEP_POINTER
} ry_sleepers;

typedef struct ry_state {
    int64_t step; /* steps done */
    double time;  /* step * dt [s] */
    ry_grains grains;
    ry_contacts contacts;
    ry_column column;
    ry_ledger ledger;
    ry_sleepers sleepers;
} ry_state;

/* Allocates the arrays of `n` grains and `nz` cells; all zero, ids 0..n-1. `ledger`: keep one. */
ry_status ry_state_create(ry_state *state, int32_t n, int32_t nz, int ledger, ry_error *error);
void ry_state_free(ry_state *state);

/* Copies everything; both were made for as many grains and cells, with or without ledger. */
ry_status ry_state_copy(ry_state *to, const ry_state *from, ry_error *error);

/* Adds the arrays of those that sleep: at first fixed grains only. */
ry_status ry_state_add_sleepers(ry_state *state, ry_error *error);

/* Makes room for `n` contacts, with or without rest, as no_rest says. */
ry_status ry_contacts_reserve(ry_contacts *contacts, int64_t n, ry_error *error);

/* Copies contacts, but for a rest that only one of the two has. */
ry_status ry_contacts_copy(ry_contacts *to, const ry_contacts *from, ry_error *error);

/* Without rest from now on. */
void ry_contacts_drop_rest(ry_contacts *contacts);

/* Leaves none, and what kind they are. */
void ry_contacts_free(ry_contacts *contacts);

/* One number for all bits of what moves: grains, contacts, column; in id order. The ledger, which only
 * watches, is left out, so that measuring does not show. */
uint64_t ry_state_hash(const ry_state *state);

/* The same with the ledger, for files. */
uint64_t ry_state_checksum(const ry_state *state);

#endif
