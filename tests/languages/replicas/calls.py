"""Makes calls as one Python program: calls.py client|function|asyncio SERVER CALLS. Exits with 5 if one fails."""

import asyncio
import sys

import curvd_client
import curvd_client.aio
import numpy as np

WAY, SERVER, CALLS = sys.argv[1], sys.argv[2], int(sys.argv[3])
CLOUD = np.float32([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]]), np.float32([[0, 0, 1]] * 4)


async def with_asyncio():
    async with curvd_client.aio.CurvatureClient(SERVER) as client:
        for _ in range(CALLS):
            await client.estimate(*CLOUD, neighbor_count=4)


def main():
    if WAY == "asyncio":
        asyncio.run(with_asyncio())
    elif WAY == "function":
        for _ in range(CALLS):
            curvd_client.estimate_curvature(*CLOUD, server=SERVER, neighbor_count=4)
    else:
        with curvd_client.CurvatureClient(SERVER) as client:
            for _ in range(CALLS):
                client.estimate(*CLOUD, neighbor_count=4)


try:
    main()
except curvd_client.CurvdError as error:
    print(error, file=sys.stderr)
    sys.exit(5)
