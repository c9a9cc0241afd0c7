/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * The smallest program on the library: grains fall, and say where they are. C and C++. */
#include <ryusa/ryusa.h>
#include <stdio.h>

int main(void)
{
    ry_error error = {RY_OK, ""};
    ry_config config = ry_config_default(1);
    config.fluid_model = RY_FLUID_NONE;
    ry_status status = ry_config_resolve(&config, &error);
    ry_sim *sim = status == RY_OK ? ry_sim_create(&config, 1, &error) : NULL;
    if (!sim || ry_sim_step(sim, 100, &error) != RY_OK) {
        fprintf(stderr, "%s\n", error.text);
        return 1;
    }
    printf("%s: %d grains, t = %g s, hash %016llx\n", ry_version(), ry_sim_view(sim).n,
           ry_sim_view(sim).time, ry_sim_hash(sim));
    ry_sim_free(sim);
    ry_config_free(&config);
    return 0;
}
