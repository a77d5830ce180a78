function R = rotation_z(alpha)
% The rotation by alpha [rad] about the z axis, 3 x 3. Its columns are the axes x, y and z after the turn, in the
% coordinates of before.
% --- yours from here on ---
    c = cos(alpha);
    s = sin(alpha);
    R = [c, -s, 0; s, c, 0; 0, 0, 1];
end
