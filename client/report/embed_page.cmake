# Writes C++ that holds a text: cmake -DPAGE=page.html -DFUNCTION=PageTemplate -DOUTPUT=page_template.cc -P embed_page.cmake
# FUNCTION, of page_template.h, returns it.
file(READ "${PAGE}" hex HEX)
string(REGEX REPLACE "(..)" "0x\\1," bytes "${hex}")
string(REGEX REPLACE "(0x..,0x..,0x..,0x..,0x..,0x..,0x..,0x..,0x..,0x..,0x..,0x..,0x..,0x..,0x..,0x..,)" "\\1\n"
       bytes "${bytes}")
file(WRITE "${OUTPUT}" "#include \"client/report/page_template.h\"

namespace curv {
namespace {
constexpr unsigned char kText[] = {
${bytes}};
}  // namespace

std::string_view ${FUNCTION}() { return {reinterpret_cast<const char*>(kText), sizeof(kText)}; }

}  // namespace curv
")
