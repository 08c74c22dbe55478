// What each use of OpenSSL begins with, here and in the server and the client.
#pragma once

#include <openssl/crypto.h>

namespace curvd {

// Keeps OpenSSL from freeing what it holds when the process exits: threads of gRPC, which nobody can wait for, still
// use it then, which crashed programs that had done their work (gRPC's issue 38539, mended there after Debian's 1.51).
// Has an effect only before the first other call of OpenSSL in a process; any thread may call it, as often as it likes.
inline void KeepOpenSslAtExit() { OPENSSL_init_crypto(OPENSSL_INIT_NO_ATEXIT, nullptr); }

}  // namespace curvd
