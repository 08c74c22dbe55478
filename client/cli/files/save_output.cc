#include "client/cli/files/save_output.h"

#include "absl/strings/str_cat.h"
#include "client/cli/command.h"
#include "client/io/pcd/pcd_frame.h"

namespace curv {

absl::Status SaveOutput(const PointTable& table, const std::string& output, const SaveOptions& options) {
  const absl::StatusOr<WritableName> name = WritableNameOf(output, options);
  if (!name.ok()) return name.status();
  if (const std::string note = NoteOnFrame(table, name->extension); !note.empty()) {
    PrintNote(absl::StrCat(ShownOutput(output), ": ", note));
  }
  return SaveTable(table, output, options);
}

}  // namespace curv
