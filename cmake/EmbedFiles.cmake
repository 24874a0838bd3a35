# cmake -DOUTPUT=file.cpp -DHEADER=table.h -DTABLE=ns::table -DNAMES="a;b" -DPATHS="/x/a;/y/b" -P EmbedFiles.cmake
# Writes the function TABLE, which HEADER declares: a map from name to the bytes of the file, and of
# scripts from `name.sha256` to the hash in hexadecimal.
set(rows "")
foreach(name path IN ZIP_LISTS NAMES PATHS)
  file(READ "${path}" bytes HEX)
  file(SIZE "${path}" size)
  string(REGEX REPLACE "(..)" "\\\\x\\1" bytes "${bytes}")
  string(APPEND rows "    {\"${name}\", {\"${bytes}\", ${size}}},\n")
  if(name MATCHES "[.]js$")
    file(SHA256 "${path}" hash)
    string(APPEND rows "    {\"${name}.sha256\", \"${hash}\"},\n")
  endif()
endforeach()
file(WRITE "${OUTPUT}.new"
  "#include \"${HEADER}\"\n\n"
  "const std::map<std::string, std::string>& ${TABLE}() {\n"
  "  static const std::map<std::string, std::string> table = {\n${rows}  };\n"
  "  return table;\n}\n")
file(COPY_FILE "${OUTPUT}.new" "${OUTPUT}" ONLY_IF_DIFFERENT)
