// Makes the last message of a call that succeeded.
#pragma once

#include "curvature/v1/curvature.pb.h"
#include "server/rpc/call_record.h"

namespace curvd {

// Everything in the summary comes from the record: also the warnings, of which there is one where normals contradict
// each other.
void FillSummary(const CallRecord& record, curvature::v1::Summary* summary);

}  // namespace curvd
