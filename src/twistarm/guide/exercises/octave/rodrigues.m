function R = rodrigues(w, theta)
% The rotation e^(w_hat theta), 3 x 3, by Rodrigues' formula. The column w may have any length, 0 too: then it is the
% identity. The angle of the turn is norm(w) * theta [rad].
% --- yours from here on ---
    len = norm(w);
    if len < 1e-12
        R = eye(3);
        return
    end
    u = w / len;
    W = [0, -u(3), u(2); u(3), 0, -u(1); -u(2), u(1), 0];
    R = eye(3) + W * sin(len * theta) + W * W * (1 - cos(len * theta));
end
