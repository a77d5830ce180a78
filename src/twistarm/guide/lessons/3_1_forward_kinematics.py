# %% [markdown]
# # Forward kinematics
#
# Where is the tool? Test $g_{st}(\theta) = e^{\hat\xi_1\theta_1} \cdots e^{\hat\xi_n\theta_n} g_{st}(0)$.
#
# ## A section

# %%
import numpy as np

from twistarm import guide

arm = guide.arm()
g = arm.fk(arm.ready)
guide.say(f"The tool stands at $x = {g[0, 3]:.3f}$ m.")
guide.table(["joint", "$v$"], [[name, float(v)] for name, v in zip(arm.joint_names, arm.screws[0], strict=True)])

# %%
fig, ax = guide.axes3()
guide.plot_arm(ax, arm)
guide.fit(ax)
guide.figure(fig, f"{arm.name} at its ready pose", "The arm.")

# %%
guide.scene(arm, caption="Move it.")

# %%
guide.slider("two_link", "Which $\\theta_2$?", "The other.")
guide.slider("frame", "Which $\\theta_2$?", "The other.")
guide.slider("axis_angle", "Which $\\theta_2$?", "The other.")
guide.slider("twist", "Which $\\theta_2$?", "The other.")
guide.slider("joint", "Which $\\theta_2$?", "The other.")
guide.slider("spline", "Which $\\theta_2$?", "The other.")
guide.slider("ellipsoid", "Which $\\theta_2$?", "The other.")
guide.predict("How many?", "Two.")

# %% tags=["reveal"]
guide.say("revealed")

# %% tags=["hidden"]
guide.say("hidden")
assert np.isfinite(g).all()
