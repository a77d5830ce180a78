# %% [markdown]
# # Quaternions
#
# The recording of your arm gives the tool's orientation as four numbers. Which one is the scalar? In the next line all
# four have changed their sign, and the gripper has not moved. And why four numbers? Three angles were enough in the
# last lesson.
#
# The last question has an answer already: any three angles fail somewhere. Four numbers do not. This lesson explains
# what the four are, how they multiply, and what you must take care of.
#
# ## From the plane to space
#
# You know such numbers in the plane. A complex number of length one, $\cos\theta + i\sin\theta$, turns every other
# complex number by $\theta$ when you multiply the two. A quaternion does the same in space. It has a scalar part $w$
# and a vector part $v$ of three components, which we write as a pair:
#
# $$Q = w + x\,\mathbf{i} + y\,\mathbf{j} + z\,\mathbf{k} = (w, v), \qquad v = (x, y, z)$$
#
# To multiply two quaternions, multiply term by term. The rules are $\mathbf{i}^2 = \mathbf{j}^2 = \mathbf{k}^2 = -1$,
# $\mathbf{i}\mathbf{j} = \mathbf{k}$, $\mathbf{j}\mathbf{k} = \mathbf{i}$ and $\mathbf{k}\mathbf{i} = \mathbf{j}$. If
# you swap two different letters, the sign changes. The product of any two quaternions is then
#
# $$Q_1\,Q_2 = (w_1 w_2 - v_1 \cdot v_2,\;\; w_1\,v_2 + w_2\,v_1 + v_1 \times v_2)$$
#
# Because of the cross product, the order of the factors matters. The *conjugate* is $Q^* = (w, -v)$.
#
# ## The law
#
# A turn by the angle $\theta$ about the unit vector $\omega$ is the unit quaternion
#
# $$Q = \left(\cos\tfrac{\theta}{2},\; \omega \sin\tfrac{\theta}{2}\right)$$
#
# and it moves the point $p$ to $p'$ by
#
# $$(0, p') = Q\,(0, p)\,Q^*$$
#
# Turns are composed as matrices are: $Q_{sc} = Q_{st}\,Q_{tc}$ for a camera C on the tool. Source: Murray, Li and
# Sastry, *A Mathematical Introduction to Robotic Manipulation* (MLS), section 2.2.3.
#
# ## Your tool in four numbers
#
# Here is the orientation of the tool in the ready configuration, as an axis with an angle and as a quaternion. Both
# come from its rotation matrix.

# %%
import numpy as np

from twistarm import guide, rotations

arm = guide.arm()
R = arm.fk(arm.ready)[:3, :3]  # of the tool, seen from the base
Q = rotations.to_quaternion_wxyz(R)
axis, angle = rotations.to_axis_angle(R)

guide.say(
    rf"The tool of `{arm.name}` is turned by ${np.degrees(angle):.1f}°$ about the axis "
    rf"$({', '.join(f'{a:.3f}' for a in axis + 0.0)})$, seen from the base."
)
guide.table(
    ["", "$w$", "$x$", "$y$", "$z$"],
    [
        ["scalar first, `wxyz`", *Q],
        ["half the angle, and the axis", np.cos(angle / 2), *(axis * np.sin(angle / 2))],
    ],
    "The same four numbers, computed in two ways.",
)

# %% [markdown]
# Now move a point with it. The product is two lines, and the law fits in one more.


# %% tags=["shown"]
def product(Q1, Q2):
    """The product Q1 Q2 of two quaternions (w, x, y, z)."""
    (w1, v1), (w2, v2) = (Q1[0], np.array(Q1[1:])), (Q2[0], np.array(Q2[1:]))
    return np.array([w1 * w2 - v1 @ v2, *(w1 * v2 + w2 * v1 + np.cross(v1, v2))])


def conjugate(Q):
    """The quaternion with its vector part reversed."""
    return Q * [1, -1, -1, -1]


# %%
p = np.array([0.10, 0.0, 0.05])  # a point of the gripper, in the tool's axes [m]
moved = product(product(Q, [0, *p]), conjugate(Q))

guide.table(
    ["", "scalar", "$x$ [m]", "$y$ [m]", "$z$ [m]"],
    [["$Q\\,(0, p)\\,Q^*$", *moved], ["$R\\,p$", "none", *(R @ p)]],
    "The same point moved by the quaternion and by the matrix.",
)

# %% [markdown]
# ## Why half the angle
#
# $Q$ is on both sides of the point, once plain and once conjugated. Each side contributes half of the turn. Try it with
# the axis $\mathbf{k}$, $Q = \cos\frac{\theta}{2} + \mathbf{k}\sin\frac{\theta}{2}$. For a point on the axis the two
# sides cancel: $Q\,\mathbf{k}\,Q^* = \mathbf{k}\,Q\,Q^* = \mathbf{k}$. For a point beside the axis they add up, because
# $\mathbf{i}\,Q^* = Q\,\mathbf{i}$:
#
# $$Q\,\mathbf{i}\,Q^* = Q\,Q\,\mathbf{i} = (\cos\theta + \mathbf{k}\sin\theta)\,\mathbf{i}
# = \mathbf{i}\cos\theta + \mathbf{j}\sin\theta$$
#
# The half angle has a consequence that no matrix has.

# %%
once_round = np.array([np.cos(np.pi), 0, 0, np.sin(np.pi)])
guide.predict(
    "Start at $Q = (1, 0, 0, 0)$, and turn about the $z$ axis by one full turn. The matrix is back where it began. What "
    "is the quaternion then? And after how many degrees is it back?",
    f"After 360° it is $({', '.join(f'{q:.0f}' for q in once_round + 0.0)})$, which is $-1$ times the start. "
    f"It is back after two full turns, 720°.",
)

# %%
turn = np.radians(np.linspace(0, 720, 241))
fig, ax = guide.axes2(xlabel="angle turned [°]")
ax.plot(np.degrees(turn), np.cos(turn), label=r"$\cos\,\theta$, an entry of $R$")
ax.plot(np.degrees(turn), np.cos(turn / 2), label=r"$w = \cos(\theta/2)$")
for full in (360, 720):
    ax.axvline(full, color=guide.GREY, linewidth=0.8, linestyle=":")
ax.set_xticks(range(0, 721, 90))
ax.set_ylim(-1.15, 1.55)
ax.legend(loc="upper center", ncols=2)
guide.figure(
    fig,
    "Two curves over two full turns. The entry of the matrix comes back after 360 degrees. The scalar part of the "
    "quaternion is then at minus one and comes back after 720 degrees.",
    "A turn of 360° brings the matrix back, and the quaternion to its negative.",
)

# %% [markdown]
# So $Q$ and $-Q$ are the same rotation: the sign occurs twice in $Q\,(0, p)\,Q^*$ and cancels. Unit quaternions are the
# points of a sphere in four dimensions. Opposite points of this sphere are the same rotation. Unit quaternions *cover
# the rotations twice*.
#
# This is the price of four numbers that fail nowhere. Three numbers cannot list each rotation once without a seam, as
# no flat map shows the whole globe. Four numbers have no seam, but they list each rotation twice.

# %%
guide.slider(
    "axis_angle",
    "Keep the axis and move the angle. At which angle is $w = 0$? And which two settings of the slider show "
    "the same matrix and opposite quaternions?",
    f"At {np.degrees(2 * np.arccos(0)):.0f}°, a half turn: $\\cos(\\theta/2) = 0$ there, and the vector part is the "
    "unit vector of the axis itself. Angles that differ by 360° show the same matrix and opposite quaternions.",
    axis=(1, 1, 1),
    angle=90,
)

# %% [markdown]
# ## Your arm as a product of quaternions
#
# From here on, S is the frame of the base (S for *space*) and T that of the tool. Let all joints be at zero. The tool
# then has the orientation $Q_{st}(0)$. Let $\omega_i$ be the unit vector along the axis of joint $i$, seen from S.
# Joint $i$ at the angle $\theta_i$ is the quaternion $Q_i = (\cos\frac{\theta_i}{2}, \omega_i\sin\frac{\theta_i}{2})$.
# A joint that slides turns nothing: it is $(1, 0)$. The orientation of the tool is the product of all, from the base to
# the tip:
#
# $$Q_{st}(\theta) = Q_1\,Q_2 \cdots Q_n\,Q_{st}(0)$$
#
# The program at the end of the page uses only these axes, and the table compares it with twistarm. All joints move, but
# the product uses the axes at zero. The lesson *Where is the tool?* (3.1) proves that this is right.

# %%
values = arm.coupling.A @ arm.ready  # of each moving joint; `A` adds those that follow others (3.1)
whole = np.array([1.0, 0, 0, 0])
for omega, value in zip(arm.screws[3:].T, values, strict=True):
    half = value / 2 * np.linalg.norm(omega)  # the norm is 1, or 0 for a slide
    whole = product(whole, [np.cos(half), *(omega * np.sin(half))])
whole = product(whole, rotations.to_quaternion_wxyz(arm.home[:3, :3]))

guide.table(
    ["", "$w$", "$x$", "$y$", "$z$"],
    [["product of the joints", *whole], ["twistarm", *Q]],
    f"{len(values)} joints of `{arm.name}`, multiplied. Where all four signs differ, the rotation is the same.",
)

# %% [markdown]
# ## The norm, and the inverse
#
# The norm of a quaternion is its length, $\|Q\| = \sqrt{w^2 + x^2 + y^2 + z^2}$. Compute $Q\,Q^*$ with the product
# above. The vector part cancels, and the scalar part is the sum of the squares. Therefore
#
# $$\|Q\|^2 = Q\,Q^*, \qquad Q^{-1} = \frac{Q^*}{\|Q\|^2}$$
#
# The square is easy to forget. If you take $Q\,Q^*$ for the norm and square it again for the inverse, you divide by the
# fourth power of the length.

# %%
four = np.array([1.0, 2.0, 3.0, 4.0])
square = product(four, conjugate(four))[0]
literal = product(four, conjugate(four) / square**2)[0]
right = product(four, conjugate(four) / square)

guide.predict(
    "For $Q = (1, 2, 3, 4)$: what is $Q\\,Q^{-1}$ if $\\|Q\\|$ is taken to be $Q\\,Q^*$? What is it for a unit "
    "quaternion?",
    f"$Q\\,Q^* = {square:.0f}$, and $Q\\,Q^{{-1}}$ comes out as $1/{1 / literal:.0f}$ instead of "
    f"${right[0]:.0f}$. For a unit quaternion it comes out right, because $1 = 1^2$. So a test with unit "
    f"quaternions alone does not find the mistake.",
)

# %% [markdown]
# A quaternion that has lost its unit length is no longer a rotation: $Q\,(0, p)\,Q^*$ stretches every point by
# $\|Q\|^2$. The remedy is one division, $Q/\|Q\|$. A matrix that has lost its right angles takes more work. For this
# reason, and because four numbers are fewer than nine, filters and recordings use quaternions.

# %%
stretched = product(product(1.05 * Q, [0, *p]), conjugate(1.05 * Q))
growth = np.linalg.norm(stretched) / np.linalg.norm(p)
guide.say(
    f"A quaternion that is 5 % too long makes the gripper {100 * (growth - 1):.1f} % larger than it is."
)

# %% [markdown]
# ## The sign in your recordings
#
# The arm has moved to a second orientation. A teammate turns the tool once about its own axis while you record. The
# program that converts matrices to quaternions must choose between $Q$ and $-Q$. Like most such programs, it takes the
# one with $w \geq 0$. Look at what this does.

# %%
R_2 = arm.fk(0.5 * arm.ready + 0.5 * arm.random_theta(3))[:3, :3] @ rotations.exp(arm.tool_axis, 0.6)
steps = np.linspace(0, 2 * np.pi, 181)
turned = R_2 @ rotations.exp(arm.tool_axis, steps)
logged = rotations.to_quaternion_wxyz(turned)
agrees = np.sign(np.sum(logged[1:] * logged[:-1], axis=1))
mended = logged * np.cumprod([1.0, *agrees])[:, None]

fig, (left, right_ax) = guide.axes2(
    2, width=6.6, height=3.0, xlabel="tool turned [°]", ylabel="component of Q"
)
for ax, curves, title in (
    (left, logged, "as logged"),
    (right_ax, mended, "each sign as its neighbour's"),
):
    ax.plot(np.degrees(steps), curves, label=["$w$", "$x$", "$y$", "$z$"])
    ax.set(title=title, xticks=range(0, 361, 90), ylim=(-1.1, 1.1))
fig.legend(*left.get_legend_handles_labels(), loc="outside lower center", ncols=4)
guide.figure(
    fig,
    "The four components while the tool turns once. On the left, as logged, they jump to their negatives on the way. "
    "On the right, with signs made to agree with the neighbour's, they are smooth and end at the negative of where "
    "they began.",
    "The tool turned at a constant rate. The jump on the left is only a choice of sign.",
)

# %% [markdown]
# The remedy is one rule: if the dot product of two neighbours is negative, change the sign of the second.
#
# Apply the same rule before every interpolation. Between two orientations there are two ways round, about the same
# axis: by $\varphi$, or by $360° - \varphi$ the other way. The signs of the two quaternions decide which one you get.
# With $\cos\frac{\varphi}{2} = Q_1 \cdot Q_2$, the orientation at the share $s$ of the way is
#
# $$Q(s) = \frac{\sin((1 - s)\,\varphi/2)}{\sin(\varphi/2)}\,Q_1 + \frac{\sin(s\,\varphi/2)}{\sin(\varphi/2)}\,Q_2$$
#
# This is *slerp*, a turn about one axis at an even rate. For $\varphi$ near 0 it divides 0 by 0: take $Q_1$ there.
# Source: Shoemake, *Animating rotation with quaternion curves*, 1985.

# %%
Q1, Q2 = Q, rotations.to_quaternion_wxyz(R_2)
Q2 = Q2 if Q1 @ Q2 >= 0 else -Q2
short, long = (2 * np.degrees(np.arccos(np.clip(Q1 @ end, -1, 1))) for end in (Q2, -Q2))

guide.say(f"""
From the orientation at ready to the second one of `{arm.name}`:

- with signs that agree, $Q_1 \\cdot Q_2 \\geq 0$, the interpolation turns the tool by **{short:.1f}°**;
- with one sign changed, it turns the tool to the same orientation by **{long:.1f}°**.

And the mean of $Q$ and $-Q$, two records of one orientation, has the length 0: it is not an orientation.
""")

# %% [markdown]
# ## What goes wrong in practice
#
# **The order of the four.** Eigen's constructor and MuJoCo put the scalar first (`wxyz`). The messages of ROS, SciPy
# and Pinocchio's configurations put it last (`xyzw`). No program complains when you mix them up, because the numbers
# are a unit quaternion in either order. In twistarm the order is in the name of the function.

# %%
misread = rotations.from_quaternion_wxyz(np.roll(Q2, -1))
guide.say(
    f"The second orientation above, written scalar last and read scalar first, is off by "
    f"**{np.degrees(rotations.angle_between(R_2, misread)):.0f}°**. Check with the identity: there the "
    f"scalar is 1, and the others are 0."
)

# %% [markdown]
# **The half angle forgotten.** $(\cos\theta, \omega\sin\theta)$ is a unit quaternion too, and it turns by $2\theta$.
# You notice it when a wrist turns by 180° instead of 90°.
#
# **Signs that jump.** A filter, a mean or a derivative across the jump gives a spike. An interpolation across it spins
# the tool once round. Make the signs agree first.
#
# **Length that drifts.** After thousands of products, rounding has changed the length. Divide by the norm after each
# update, not once a day.
#
# **The wrong side.** In $Q_{st}\,Q_{tc}$ the inner letters meet. To turn about the tool's own axes, multiply from the
# right; about the base's axes, from the left. The conjugate of $Q_{st}$ is $Q_{ts}$. If you confuse the two, the tool
# tilts to the wrong side.

# %%
turns = {name: rotations.exp(unit, np.radians(60)) for name, unit in zip("xyz", np.eye(3), strict=True)}
differences = {
    name: np.degrees(rotations.angle_between(turn @ R_2, R_2 @ turn)) for name, turn in turns.items()
}
worst = max(differences, key=differences.get)
guide.say(
    f"At the second orientation above, a turn by 60° about the base's ${worst}$ axis and one about the tool's "
    f"${worst}$ axis leave the tool {differences[worst]:.0f}° apart."
)

# %% [markdown]
# ## Exercises

# %%
guide.practice("2_1_1_quaternions")
