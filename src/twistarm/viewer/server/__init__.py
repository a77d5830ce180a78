"""The web server of the view: sockets, who gets in, routes and downloads."""
