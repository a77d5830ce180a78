"""Files of the view: stand-alone pages, pictures, and the view inside a notebook."""
