"""Interactive charts of a well's page, drawn by Bokeh in the browser."""
