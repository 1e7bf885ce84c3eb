"""A robot arm's motion, checked, and what it really draws; needs limner[robot]: python 08_arm.py me.jpg"""

import sys

import limner
from limner.motion.arm.plan import plan_arm
from limner.motion.arm.robots import load_robot
from limner.simulation.outcome import simulate

settings = limner.Settings()
robot = load_robot("dumbo")
portrait = limner.draw(sys.argv[1], points=150)
planned = plan_arm(portrait.drawing, robot, settings.arm)
limner.save(planned.trajectory, "trajectory.npz")
print(f"{planned.trajectory.t_s[-1]:.0f} s, {planned.report()['margin_deg']:.0f} degrees from the joints' limits")

made = simulate(planned.trajectory, robot, settings.simulation, portrait.drawing)
report = made.report()
print(f"ink within {report['ink_error_mm']['p95']:.2f} mm; touches for {report['contact_percent']:.1f} %")
