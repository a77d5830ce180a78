function g = product_of_exponentials(twists, home, x)
% The pose of the tool, 4 x 4. Each column of twists is the twist [v; w] of a joint, seen from the base in the home
% configuration. home is the tool's pose there, x are the joint values [rad, m]. Your twist_exp is in this folder.
% --- yours from here on ---
    g = eye(4);
    for i = 1:numel(x)
        g = g * twist_exp(twists(:, i), x(i));
    end
    g = g * home;
end
