function J = spatial_jacobian(screws, x)
% The spatial Jacobian, 6 x m: column i is the twist of joint i where the joints before it have brought it. Your
% twist_exp and adjoint stand beside this file.
% --- yours from here on ---
    J = zeros(size(screws));
    g = eye(4);
    for i = 1:numel(x)
        J(:, i) = adjoint(g) * screws(:, i);
        g = g * twist_exp(screws(:, i), x(i));
    end
end
