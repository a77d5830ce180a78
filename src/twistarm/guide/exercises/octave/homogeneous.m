function g = homogeneous(R, p)
% The pose, 4 x 4, of a frame with rotation R and origin p, a column: [R, p; 0, 1].
% --- yours from here on ---
    g = [R, p; 0, 0, 0, 1];
end
