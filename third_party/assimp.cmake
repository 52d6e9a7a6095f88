# Mesh formats other than OBJ and PLY, skinned and animated bodies. Included by host/io only.
weft_require(assimp::assimp libassimp-dev assimp CONFIG)
