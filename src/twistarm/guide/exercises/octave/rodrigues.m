function R = rodrigues(omega, theta)
% The rotation e^(omega_hat theta), 3 x 3, by Rodrigues' formula. The column omega may have any length, 0 too. The angle
% of the turn is norm(omega) * theta [rad]: the length is a part of it. Where it is 0, that is the identity.
% --- yours from here on ---
    len = norm(omega);
    if len < 1e-12
        R = eye(3);
        return
    end
    u = omega / len;
    W = [0, -u(3), u(2); u(3), 0, -u(1); -u(2), u(1), 0];
    R = eye(3) + W * sin(len * theta) + W * W * (1 - cos(len * theta));
end
