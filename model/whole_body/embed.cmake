# Writes the C++ source that holds the tables of the whole body.
# Usage: cmake -DOUTPUT=FILE.cc -DROOT=PROJECT -P embed.cmake
file(GLOB tables RELATIVE ${ROOT} ${ROOT}/model/whole_body/*.csv)
set(entries "")
foreach(table IN LISTS tables)
  file(READ ${ROOT}/${table} text)
  string(APPEND entries "    {\"${table}\", R\"csv(${text})csv\"},\n")
endforeach()
file(WRITE ${OUTPUT} "#include \"model/whole_body_table.h\"

namespace sinew::anatomy {

std::span<const EmbeddedTable> whole_body_tables() {
  static constexpr EmbeddedTable kTables[] = {
${entries}  };
  return kTables;
}

}  // namespace sinew::anatomy
")
