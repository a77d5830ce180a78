function step = damped_step(J, e, damping)
% The step, a column, of damped least squares for the Jacobian J and the error twist e: the one that makes
% norm(J * step - e)^2 + damping^2 * norm(step)^2 least.
% --- yours from here on ---
    step = J' * ((J * J' + damping^2 * eye(6)) \ e);
end
