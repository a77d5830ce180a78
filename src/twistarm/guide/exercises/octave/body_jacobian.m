function J = body_jacobian(twists, home, x)
% The body Jacobian, 6 x m: the spatial one seen from the tool, Ad(g_st^-1) * J_s.
% --- yours from here on ---
    g = product_of_exponentials(twists, home, x);
    J = adjoint(inv(g)) * spatial_jacobian(twists, x);
end
