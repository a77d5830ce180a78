function points_a = transform_points(g_ab, points_b)
% The coordinates in frame A of N points, given by their coordinates in frame B: a row each, N x 3.
% --- yours from here on ---
    count = size(points_b, 1);
    moved = g_ab * [points_b, ones(count, 1)]';
    points_a = moved(1:3, :)';
end
