"""The messages and enums of the contract, by the names that protoc gives them; their types are in curvature_pb2.pyi."""

from google.protobuf.internal import enum_type_wrapper

from curvd_client.contract import contract_file, message_class

DESCRIPTOR = contract_file()
for _name, _message in DESCRIPTOR.message_types_by_name.items():
    globals()[_name] = message_class(_message.full_name)
for _name, _enum in DESCRIPTOR.enum_types_by_name.items():
    globals()[_name] = enum_type_wrapper.EnumTypeWrapper(_enum)
    globals().update({_value.name: _value.number for _value in _enum.values})
