# Sewing patterns in SVG, which is XML.
weft_require(EXPAT::EXPAT libexpat1-dev EXPAT)
