function q_s = tool_point(g_st, g_tc, q_c)
% Where a point is, seen from the base S, a column: the tool T is at g_st, a camera C is mounted on it at g_tc, and the
% camera sees the point at q_c.
% --- yours from here on ---
    q = g_st * g_tc * [q_c; 1];
    q_s = q(1:3);
end
