#include "client/cli/files/save_output.h"

#include "absl/strings/str_cat.h"
#include "client/io/pcd/pcd_frame.h"

namespace curv {

ExitCode CheckOutput(const std::string& output, const SaveOptions& options) {
  const absl::Status writable = CheckWritable(output, options);
  if (writable.ok()) return ExitCode::kOk;
  return Fail(absl::IsFailedPrecondition(writable) ? ExitCode::kUsage : ExitCode::kOutput, writable);
}

absl::Status SaveOutput(const PointTable& table, const std::string& output, const SaveOptions& options) {
  const absl::StatusOr<WritableName> name = WritableNameOf(output, options);
  if (!name.ok()) return name.status();
  if (const std::string note = NoteOnFrame(table, name->extension); !note.empty()) {
    PrintNote(absl::StrCat(ShownOutput(output), ": ", note));
  }
  return SaveTable(table, output, options);
}

}  // namespace curv
