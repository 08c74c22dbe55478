// Makes the last message of a call that succeeded.
#pragma once

#include "curvature/v1/curvature.pb.h"
#include "server/rpc/call_record.h"

namespace curvd {

// Everything in the summary comes from the record: also the warnings, where positions are rounded too coarsely, where
// normals contradict each other, where the sides to which they were turned are doubtful, and where no point has a
// result.
void FillSummary(const CallRecord& record, curvature::v1::Summary* summary);

}  // namespace curvd
