/* SPDX-License-Identifier: MIT
 * SPDX-FileCopyrightText: 2026 the ryusa authors
 *
 * Contacts in a viscous fluid: what it leaves of the restitution is decided in the step in which they close. */
#include <math.h>

#include "stage/contact.h"

double ry_contact_wet(const ry_film *film, const ry_law_coef *coef, double a, double c, double loss)
{
    if (!film->damps) {
        return ry_wet_restitution(coef->e, loss);
    }
    const double root = film->unit * sqrt(a);
    /* what the step bears; and no more than stops the approach within it */
    const double most = ry_min(0.999 * 0.5 * (4.0 / film->many - a), 1.0) / root;
    return film->unit * ry_wet_damping(c / root, loss, most, film->usual);
}

/* Of grains i and j that close with the approach [m/s]. */
static double film_between(const ry_contact *c, const ry_grains *g, int32_t i, int32_t j, double approach)
{
    const double ri = g->radius[i], rj = g->radius[j], volume = 4.0 / 3.0 * 3.141592653589793;
    const double im_i = c->im[i] > 0.0 ? 1.0 / (volume * ri * ri * ri * g->density[i]) : 0.0;
    const double im_j = c->im[j] > 0.0 ? 1.0 / (volume * rj * rj * rj * g->density[j]) : 0.0;
    const double curvature = (ri > 0.0 ? 1.0 / ri : 0.0) + (rj > 0.0 ? 1.0 / rj : 0.0);
    const double stokes = approach * ry_wet_stokes(c->film.per_mu, im_i + im_j, curvature);
    const double a = c->coef.k_dt2 * (c->im[i] + c->im[j]);
    const double damping = c->coef.zeta2 > 0.0 ? c->coef.zeta2 * sqrt(a) : c->coef.eta_dt * (c->im[i] + c->im[j]);
    return ry_contact_wet(&c->film, &c->coef, a, damping, ry_wet_loss(stokes));
}

/* The first step of a contact decides, from its speed, what the fluid leaves; the contact keeps it. */
void ry_contact_film(const ry_contact *c, const ry_grains *g, ry_near *near)
{
    for (int32_t k = 0; k < near->n_padded; k++) {
        const int touches = near->distance[k] < near->radii[k];
        if (touches && near->age[k] == 0.0) {
            const double closing = -(near->dvx[k] * near->dx[k] + near->dvz[k] * near->dz[k]);
            near->wet[k] = film_between(c, g, near->i[k], near->j[k], closing / near->distance[k]);
        } else if (!touches) {
            near->wet[k] = 0.0;
        }
    }
}
