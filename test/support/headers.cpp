// Nothing: the target that compiles it holds the headers that the tests share (test/CMakeLists.txt).
