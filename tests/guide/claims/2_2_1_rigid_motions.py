# ## The law
assert np.allclose((g_st @ point)[:3], g_st[:3, :3] @ point[:3] + g_st[:3, 3])
assert np.isclose(np.linalg.norm(g_st @ vector), np.linalg.norm(vector))

# ## Frames in a row
assert np.allclose(g_sf[:3, 3], (g_st @ point)[:3])
assert np.allclose(g_sf, (pin.SE3(g_st) * pin.SE3(g_tf)).homogeneous)
assert np.allclose(arm.with_tool(g_tf, "screwdriver").fk(theta), g_sf)

# ## The way back
assert np.allclose(g_ts @ g_st, np.eye(4))
assert np.allclose(g_ts, np.linalg.inv(g_st))

# ## In use: the camera and the rock
assert np.allclose(g_st @ (point + d_t), q_s)
assert np.isclose(np.linalg.norm(d_t), np.linalg.norm(q_s - g_st @ point))
assert not any(np.allclose(arm.fk(x), g_st) for x in moved.values())
