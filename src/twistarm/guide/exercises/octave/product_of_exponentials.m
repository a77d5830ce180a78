function g = product_of_exponentials(screws, home, x)
% The pose of the tool, 4 x 4. A joint's twist [v; w], seen from the base where all joints are at 0, stands in each
% column of screws; home is the tool there; x are the joints' values [rad, m]. Your twist_exp stands beside this file.
% --- yours from here on ---
    g = eye(4);
    for i = 1:numel(x)
        g = g * twist_exp(screws(:, i), x(i));
    end
    g = g * home;
end
