# Pictures: previews, rendered frames, charts.
weft_require(PNG::PNG libpng-dev PNG)
