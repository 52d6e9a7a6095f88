# Headers only: scene files and reports.
weft_require(nlohmann_json::nlohmann_json nlohmann-json3-dev nlohmann_json 3.9)
