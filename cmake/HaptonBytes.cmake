# Writes the bytes of a file into a C++ source that defines the array NAME and its size, NAME_size:
# cmake -DIN=FILE -DOUT=FILE.cc -DNAME=NAME -P cmake/HaptonBytes.cmake
file(READ "${IN}" bytes HEX)
string(REGEX REPLACE "(..)" "0x\\1," bytes "${bytes}")
string(REGEX REPLACE "((0x..,){32})" "\\1\n" bytes "${bytes}")
file(WRITE "${OUT}" "extern \"C\" const unsigned char ${NAME}[] = {\n${bytes}};\nextern \"C\" const unsigned long ${NAME}_size = sizeof ${NAME};\n")
