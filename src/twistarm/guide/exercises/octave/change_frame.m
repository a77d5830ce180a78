function q_s = change_frame(R_st, R_tc, q_c)
% The coordinates q_s, a column, in frame S of the point that has q_c in frame C. The frames share their origin.
% --- yours from here on ---
    q_s = R_st * R_tc * q_c;
end
