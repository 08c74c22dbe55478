"""The messages and enums of curvature.v1, and those of google.rpc that errors carry, in a descriptor pool of their own.

A program may hold another copy of the contract, or another version of it: the two know nothing of each other. Messages
are built from the descriptors in contract.binpb when they are asked for, so no code that a certain version of protoc
wrote has to suit the protobuf that is installed.
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
    columns = []
    option_class = _column_option_class()
    for file in descriptor_pb2.FileDescriptorSet.FromString(_DESCRIPTORS).file:
        for message in file.message_type:
            if (file.name, message.name) == (_FILE, "ResultChunk"):
                for field in message.field:
                    option = option_class.FromString(field.options.SerializeToString())
                    if option.HasField("column"):
                        columns.append((field.name, option.column))
    if not columns:
        raise RuntimeError(f"{_FILE} has no columns of results: the package is damaged")
    return columns


def _column_option_class() -> Any:
    """A message that reads FieldOptions and knows of the option `column` alone.

    Which pool's extensions FieldOptions itself knows differs between the implementations of protobuf.
    """
    column = contract_file().extensions_by_name["column"]
    field = descriptor_pb2.FieldDescriptorProto(
        name="column",
        number=column.number,
        label=descriptor_pb2.FieldDescriptorProto.LABEL_OPTIONAL,
        type=descriptor_pb2.FieldDescriptorProto.TYPE_MESSAGE,
        type_name=f".{column.message_type.full_name}",
    )
    file = descriptor_pb2.FileDescriptorProto(
        name="curvd_client/column_option.proto",
        package="curvd_client",
        syntax="proto3",
        dependency=[_FILE],
        message_type=[descriptor_pb2.DescriptorProto(name="ColumnOption", field=[field])],
    )
    _POOL.AddSerializedFile(file.SerializeToString())
    return message_class("curvd_client.ColumnOption")
