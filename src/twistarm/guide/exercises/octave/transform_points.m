function points_s = transform_points(g_st, points_t)
% The coordinates in frame S of N points, given by their coordinates in frame T: a row each, N x 3.
% --- yours from here on ---
    count = size(points_t, 1);
    moved = g_st * [points_t, ones(count, 1)]';
    points_s = moved(1:3, :)';
end
