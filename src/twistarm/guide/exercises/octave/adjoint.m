function Ad = adjoint(g)
% The Adjoint, 6 x 6, of a pose g = g_st: it takes a twist [v; w] seen from T to the same seen from S.
% --- yours from here on ---
    R = g(1:3, 1:3);
    p = g(1:3, 4);
    P = [0, -p(3), p(2); p(3), 0, -p(1); -p(2), p(1), 0];
    Ad = [R, P * R; zeros(3), R];
end
