function R = zyz(alpha, beta, gamma)
% The rotation, 3 x 3, of the ZYZ Euler angles: turn by alpha about z, then by beta about the new y axis, then by gamma
% about the new z axis, all in rad.
% --- yours from here on ---
    turn_z = @(a) [cos(a), -sin(a), 0; sin(a), cos(a), 0; 0, 0, 1];
    turn_y = @(a) [cos(a), 0, sin(a); 0, 1, 0; -sin(a), 0, cos(a)];
    R = turn_z(alpha) * turn_y(beta) * turn_z(gamma);
end
