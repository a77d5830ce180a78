function x = solve_pose(twists, home, x0, target)
% Joint values, a column [rad, m], that bring the tool to target, 4 x 4, searched from x0, which is near. Repeat: the
% error inv(g) * target as a twist (real(logm(...)) and the numbers of its matrix), a damped step of the body Jacobian.
% --- yours from here on ---
    x = x0;
    for k = 1:100
        g = product_of_exponentials(twists, home, x);
        E = real(logm(g \ target));
        e = [E(1:3, 4); E(3, 2); E(1, 3); E(2, 1)];
        if max(abs(e)) < 1e-10
            break
        end
        x = x + damped_step(body_jacobian(twists, home, x), e, 1e-4);
    end
end
