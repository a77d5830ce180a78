function back = inverse_pose(g)
% The inverse, 4 x 4, of a pose g. The formula with R' takes no elimination; inv gives the same numbers.
% --- yours from here on ---
    R = g(1:3, 1:3);
    p = g(1:3, 4);
    back = [R', -R' * p; 0, 0, 0, 1];
end
