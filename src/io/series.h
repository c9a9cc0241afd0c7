/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * What a result file holds over time, each list once: the samples of ry_sample, the columns of a
 * frame, the profiles. They make the arrays of the file, the table of docs/file-format.md and what
 * `ryusa info` tells. */
#ifndef RY_IO_SERIES_H
#define RY_IO_SERIES_H

/* RY_SERIES(member of ry_sample, path, unit, field that asks for it, text) */
#define RY_LIST_series(RY_SERIES)                                                          \
    RY_SERIES(q_star, "observables/q_star", "1", RY_FIELD_FLUX,                            \
              "dimensionless sediment flux, sphere volumes over a slab of width d")        \
    RY_SERIES(q_b, "observables/q_b", "m^2/s", RY_FIELD_FLUX, "sediment flux per width")   \
    RY_SERIES(bed_level, "observables/bed_level", "m", RY_FIELD_FLUX, "height of the bed") \
    RY_SERIES(kinetic_energy, "observables/kinetic_energy", "J", RY_FIELD_FLUX,            \
              "energy of translation and spin, with added mass")                           \
    RY_LIST_energy(RY_SERIES)

#define RY_LIST_energy(RY_SERIES)                                                                \
    RY_SERIES(kinetic_energy, "observables/energy/kinetic", "J", RY_FIELD_ENERGY,                \
              "energy of translation and spin, with added mass")                                 \
    RY_SERIES(gravity_energy, "observables/energy/gravity", "J", RY_FIELD_ENERGY,                \
              "buoyant weight times height")                                                     \
    RY_SERIES(elastic_normal, "observables/energy/elastic_normal", "J", RY_FIELD_ENERGY,         \
              "in the normal springs of the contacts")                                           \
    RY_SERIES(elastic_tangential, "observables/energy/elastic_tangential", "J", RY_FIELD_ENERGY, \
              "in the tangential springs of the contacts")                                       \
    RY_SERIES(fluid_work, "observables/energy/fluid_work", "J", RY_FIELD_ENERGY,                 \
              "work of the fluid on the grains since step 0")                                    \
    RY_SERIES(loss_impact, "observables/energy/loss_impact", "J", RY_FIELD_ENERGY,               \
              "lost by restitution at impact since step 0")                                      \
    RY_SERIES(loss_dashpot, "observables/energy/loss_dashpot", "J", RY_FIELD_ENERGY,             \
              "lost by normal and tangential dashpots since step 0")                             \
    RY_SERIES(loss_friction, "observables/energy/loss_friction", "J", RY_FIELD_ENERGY,           \
              "lost by sliding since step 0")                                                    \
    RY_SERIES(loss_opening, "observables/energy/loss_opening", "J", RY_FIELD_ENERGY,             \
              "lost with the tangential spring of contacts that open, since step 0")             \
    RY_SERIES(integration, "observables/energy/integration", "J", RY_FIELD_ENERGY,               \
              "gained (+) or lost (-) by the time stepping since step 0")

/* Where q_star goes when the flux isn't asked for: a resumed run needs it for the mean. */
#define RY_HIDDEN_FLUX "checkpoint/q_star"

/* RY_FRAME(name, file type, components, unit, needs the domain to be periodic, field, text) */
#define RY_LIST_frame(RY_FRAME)                                                            \
    RY_FRAME(position, H5T_NATIVE_DOUBLE, 2, "m", 0, RY_FIELD_POSITION,                    \
             "centres x, z; within the box where it is periodic")                          \
    RY_FRAME(image, H5T_NATIVE_INT32, 2, "1", 1, RY_FIELD_POSITION,                        \
             "how often the box was left: position + image * edges is the unwrapped path") \
    RY_FRAME(velocity, H5T_NATIVE_DOUBLE, 2, "m/s", 0, RY_FIELD_VELOCITY, "along x and z") \
    RY_FRAME(spin, H5T_NATIVE_DOUBLE, 1, "rad/s", 0, RY_FIELD_SPIN,                        \
             "angular velocity about y, positive from z towards x")

/* RY_PROFILE(member of ry_profile, unit, text) */
#define RY_LIST_profile(RY_PROFILE)                                          \
    RY_PROFILE(phi, "1", "solid fraction")                                   \
    RY_PROFILE(u_grain, "m/s", "velocity of the grains, weighted by volume") \
    RY_PROFILE(u_fluid, "m/s", "velocity of the fluid")                      \
    RY_PROFILE(tau_fluid, "Pa", "stress of the fluid on horizontal planes; models log and stress: what tau_b leaves of the forces on grains above")  \
    RY_PROFILE(tau_grain, "Pa", "stress of the grains on horizontal planes")

/* What q* is; `excess` is "(s-1) ", or "" without a fluid. */
#define RY_CONVENTION(excess)                                                                      \
    "sphere volumes over a slab of width d: q_b = sum(V u)/(L d), q* = q_b/sqrt(" excess "g d^3), " \
    "moving and resting grains alike"

#endif
