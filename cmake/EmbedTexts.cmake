# cmake -DOUTPUT=file.cpp -DHEADER=table.h -DTABLE=ns::table -DNAMES="a;b" -DPATHS="/x/a;/y/b" -P EmbedTexts.cmake
# Writes the function TABLE, which HEADER declares: a map from name to the text of the file.
set(rows "")
foreach(name path IN ZIP_LISTS NAMES PATHS)
  file(READ "${path}" text)
  string(APPEND rows "    {\"${name}\", R\"embedded(${text})embedded\"},\n")
endforeach()
file(WRITE "${OUTPUT}.new"
  "#include \"${HEADER}\"\n\n"
  "const std::map<std::string, std::string>& ${TABLE}() {\n"
  "  static const std::map<std::string, std::string> table = {\n${rows}  };\n"
  "  return table;\n}\n")
file(COPY_FILE "${OUTPUT}.new" "${OUTPUT}" ONLY_IF_DIFFERENT)
