/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * Parameters that a scene has no use for, for who reads them (`ryusa show`). */
#include <math.h>
#include <stddef.h>

#include "config/keys.h"
#include "config/laws.h"

static const char *idle_contact(const ry_config *config, int key)
{
    const ry_law_kind law = ry_laws[config->contact_law];
    const ry_derived q = ry_config_derive(config);
    const int asked = law.ratio && !isnan(q.zeta_impact) && q.zeta_impact != q.zeta_pair; /* for a restitution */
    const int stiff = !isnan(config->contact_stiffness);
    switch (key) {
    case RY_KEY_contact_alpha_m: return stiff ? "contact.stiffness replaces it" : NULL;
    case RY_KEY_contact_alpha_cn: return asked ? "the damping is that of contact.restitution" : NULL;
    case RY_KEY_contact_beta: return stiff && asked ? "stiffness and damping are given otherwise" : NULL;
    case RY_KEY_contact_mapping:
        return !law.ratio || law.pulls ? "the law has one mapping" : asked ? NULL : "no restitution is asked for";
    default: return NULL;
    }
}

static const char *idle_fluid(const ry_config *config, int key)
{
    const ry_fluid model = config->fluid_model;
    if (model == RY_FLUID_NONE) {
        return key == RY_KEY_fluid_model ? NULL : "there is no fluid";
    }
    switch (key) {
    case RY_KEY_fluid_shields: return isnan(config->fluid_shear_stress) ? NULL : "fluid.shear_stress replaces it";
    case RY_KEY_fluid_roughness:
    case RY_KEY_fluid_level: return model == RY_FLUID_LOG ? NULL : "of model log";
    case RY_KEY_fluid_mixing_length: return model == RY_FLUID_BALANCE ? NULL : "of model balance";
    case RY_KEY_fluid_eddy_time: return config->fluid_turbulence == RY_TURBULENCE_WALK ? NULL : "there are no eddies";
    default: return NULL;
    }
}

const char *ry_keys_idle(const ry_config *config, int key)
{
    const int section = ry_keys_section(ry_keys_row(key)->section);
    return section == ry_keys_section("contact") ? idle_contact(config, key)
           : section == ry_keys_section("fluid") ? idle_fluid(config, key)
                                                 : NULL;
}
