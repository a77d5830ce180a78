function g = twist_exp(xi, theta)
% The motion e^(xi_hat theta), 4 x 4, of the twist xi = [v; w], whose w has the length 1, or is 0: then it is the
% translation by v * theta.
% --- yours from here on ---
    v = xi(1:3);
    w = xi(4:6);
    W = [0, -w(3), w(2); w(3), 0, -w(1); -w(2), w(1), 0];
    g = expm([W, v; 0, 0, 0, 0] * theta);
end
