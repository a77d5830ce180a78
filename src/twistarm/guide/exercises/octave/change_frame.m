function q_a = change_frame(R_ab, R_bc, q_c)
% The coordinates q_a, a column, in frame A of the point that has q_c in frame C. The frames share their origin.
% --- yours from here on ---
    q_a = R_ab * R_bc * q_c;
end
