function J = spatial_jacobian(twists, x)
% The spatial Jacobian, 6 x m: column i is the twist of joint i where the joints before it have brought it. Your
% twist_exp and adjoint are in this folder.
% --- yours from here on ---
    J = zeros(size(twists));
    g = eye(4);
    for i = 1:numel(x)
        J(:, i) = adjoint(g) * twists(:, i);
        g = g * twist_exp(twists(:, i), x(i));
    end
end
