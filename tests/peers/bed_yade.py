# SPDX-License-Identifier: MIT
# SPDX-FileCopyrightText: 2026 the ryusa authors
"""A bed of ryusa in YADE, run by yade itself: yade -n -x -jN bed_yade.py, its task (JSON) in PEERS_TASK.

x along the bed, y across it, z up; the fluid is YADE's own HydroForceEngine with an imposed profile. Its drag is
C_d = 0.44 + 24.4/Re, of a fluid that is denser by the factor that gives the grains at the start the drag of the
other programs; its gravity is smaller by the same factor, so that buoyancy stays. Prints a line of JSON per round."""
import json
import math
import os
import time

import numpy as np

task = json.loads(os.environ["PEERS_TASK"])
state = np.load(task["state"])
law = task["law"]

O.periodic = True
high = 4.0 * float(state["z"].max())
O.cell.hSize = Matrix3(task["length"], 0, 0, 0, high, 0, 0, 0, high)
base = 0.25 * high  # nothing crosses the lower or upper end of the cell

# a contact gets a b/(a + b) of its partners' constants (2023.02a: not twice that, as its manual has it)
mean_density = float(state["density"].mean())
sand = O.materials.append(ViscElMat(density=mean_density, frictionAngle=math.atan(law["mu"]), kn=2.0 * law["k"],
                                    ks=2.0 * law["kt"], cn=2.0 * law["eta"], cs=2.0 * law["eta_t"]))
bodies = []
columns = (state[k].tolist() for k in ("x", "z", "vx", "vz", "spin", "radius", "fixed"))
for x, z, vx, vz, spin, r, fixed in zip(*columns):
    body = sphere((x, 0.5 * high, base + z), r, fixed=bool(fixed), material=sand)
    if not fixed:
        body.state.blockedDOFs = "yXZ"
        body.state.vel = (vx, 0, vz)
        body.state.angVel = (0, spin, 0)
    bodies.append(body)
O.bodies.append(bodies)
moving = [b.id for b in O.bodies if b.state.blockedDOFs == "yXZ"]

engines = [
    ForceResetter(),
    InsertionSortCollider([Bo1_Sphere_Aabb()], verletDist=task["skin"]),
    InteractionLoop([Ig2_Sphere_Sphere_ScGeom()], [Ip2_ViscElMat_ViscElMat_ViscElPhys()],
                    [Law2_ScGeom_ViscElPhys_Basic()]),
]
water = None
if task["fluid"]:
    water = HydroForceEngine(ids=moving, densFluid=task["rho"], viscoDyn=task["rho"] * task["nu"], zRef=base,
                             gravity=(0, 0, -task["lift"]), deltaZ=task["cell"], nCell=len(task["fluid"]),
                             expoRZ=0.0)
    engines.append(water)
engines.append(NewtonIntegrator(gravity=(0, 0, -task["gravity"]), damping=0.0))
O.engines = engines
if water:
    water.initialization()
    water.vxFluid = [0.0] + task["fluid"]
O.dt = task["dt"]
O.trackEnergy = False

O.run(task["warm"], True)
for _ in range(task["rounds"]):
    begun = time.perf_counter()
    O.run(task["steps"], True)
    seconds = time.perf_counter() - begun
    kinetic = sum(0.5 * O.bodies[k].state.mass * O.bodies[k].state.vel.squaredNorm() for k in moving)
    height = sum(O.bodies[k].state.pos[2] for k in moving) / len(moving) - base
    contacts = sum(1 for i in O.interactions if i.isReal)
    told = {"seconds": seconds, "energy": kinetic, "height": height, "contacts": contacts}
    print("peers: " + json.dumps(told), flush=True)
