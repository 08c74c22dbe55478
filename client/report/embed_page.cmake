# Writes C++ that holds a page as text: cmake -DPAGE=page.html -DOUTPUT=page_template.cc -P embed_page.cmake
file(READ "${PAGE}" hex HEX)
string(REGEX REPLACE "(..)" "0x\\1," bytes "${hex}")
string(REGEX REPLACE "(0x..,0x..,0x..,0x..,0x..,0x..,0x..,0x..,0x..,0x..,0x..,0x..,0x..,0x..,0x..,0x..,)" "\\1\n"
       bytes "${bytes}")
file(WRITE "${OUTPUT}" "#include \"client/report/page_template.h\"

namespace curv {
namespace {
constexpr unsigned char kPage[] = {
${bytes}};
}  // namespace

std::string_view PageTemplate() { return {reinterpret_cast<const char*>(kPage), sizeof(kPage)}; }

}  // namespace curv
")
