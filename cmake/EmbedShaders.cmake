# cmake -DOUTPUT=file.cpp -DROOT=dir -DFILES="a;b" -P EmbedShaders.cmake
# Writes the shader files as a table of name and text.
set(rows "")
foreach(file IN LISTS FILES)
  file(READ "${ROOT}/${file}" text)
  string(APPEND rows "    {\"${file}\", R\"glsl(${text})glsl\"},\n")
endforeach()
file(WRITE "${OUTPUT}.new"
  "#include \"gl/embedded_shaders.h\"\n\nnamespace psivox::gl {\n\n"
  "const std::map<std::string, std::string>& embedded_shaders() {\n"
  "  static const std::map<std::string, std::string> table = {\n${rows}  };\n"
  "  return table;\n}\n\n}  // namespace psivox::gl\n")
file(COPY_FILE "${OUTPUT}.new" "${OUTPUT}" ONLY_IF_DIFFERENT)
