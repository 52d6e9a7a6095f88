# GoogleTest and its matchers.
weft_require(GTest::gtest_main libgtest-dev GTest 1.11)
if(NOT TARGET GTest::gmock)
  message(FATAL_ERROR "gmock was not found. Install it (apt-get install libgmock-dev).")
endif()
include(GoogleTest)
