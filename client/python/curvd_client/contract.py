"""The messages and enums of curvature.v1, and those of google.rpc that errors carry, in a descriptor pool of their own.

A program may hold another copy of the contract, or another version of it: the two know nothing of each other. Messages are
built from the descriptors in contract.binpb when they are asked for, so no code that a certain version of protoc wrote has to
suit the protobuf that is installed.
"""

from __future__ import annotations

import pathlib
from typing import Any

from google.protobuf import descriptor_pb2, descriptor_pool, message_factory

_FILE = "curvature/v1/curvature.proto"
_DESCRIPTORS = pathlib.Path(__file__).with_name("contract.binpb").read_bytes()


def _load_pool() -> Any:
    pool = descriptor_pool.DescriptorPool()
    for file in descriptor_pb2.FileDescriptorSet.FromString(_DESCRIPTORS).file:
        pool.AddSerializedFile(file.SerializeToString())
    return pool


_POOL = _load_pool()


def contract_file() -> Any:
    """The descriptor of the contract's own file."""
    return _POOL.FindFileByName(_FILE)


def message_class(full_name: str) -> Any:
    """The class of a message of this pool, such as "google.rpc.Status"."""
    descriptor = _POOL.FindMessageTypeByName(full_name)
    if hasattr(message_factory, "GetMessageClass"):
        return message_factory.GetMessageClass(descriptor)
    return message_factory.MessageFactory(_POOL).GetPrototype(descriptor)


def result_columns() -> list[tuple[str, Any]]:
    """Name and Column of each field of ResultChunk that is a column of results, in the order of the contract."""
    # Read from the file, not asked of the descriptor: what that answers, classes of another pool may have made.
    files = message_class("google.protobuf.FileDescriptorSet")
    message_class("google.protobuf.FieldOptions")
    option = _POOL.FindExtensionByName("curvature.v1.column")
    for file in files.FromString(_DESCRIPTORS).file:
        for message in file.message_type:
            if (file.name, message.name) == (_FILE, "ResultChunk"):
                return [
                    (field.name, field.options.Extensions[option])
                    for field in message.field
                    if field.options.HasExtension(option)
                ]
    raise RuntimeError(f"{_FILE} has no ResultChunk")
