// Makes calls as one Go program: calls SERVER CALLS. Exits with 5 if one fails.
package main

import (
	"bytes"
	"context"
	"encoding/binary"
	"fmt"
	"io"
	"os"
	"strconv"

	pb "curvature/v1"

	"google.golang.org/grpc"
)

func floats(values ...float32) []byte {
	var buffer bytes.Buffer
	binary.Write(&buffer, binary.LittleEndian, values)
	return buffer.Bytes()
}

func estimate(client pb.CurvatureServiceClient) error {
	call, err := client.EstimateCurvature(context.Background())
	if err != nil {
		return err
	}
	header := &pb.CloudHeader{
		PointCount: 4,
		ScalarType: pb.ScalarType_SCALAR_TYPE_FLOAT32,
		Options:    &pb.EstimatorOptions{Neighborhood: &pb.EstimatorOptions_NeighborCount{NeighborCount: 4}},
	}
	chunk := &pb.PointChunk{
		Positions: floats(0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0),
		Normals:   floats(0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1),
	}
	call.Send(&pb.EstimateCurvatureRequest{Message: &pb.EstimateCurvatureRequest_Header{Header: header}})
	call.Send(&pb.EstimateCurvatureRequest{Message: &pb.EstimateCurvatureRequest_Chunk{Chunk: chunk}})
	call.CloseSend()
	for {
		if _, err := call.Recv(); err == io.EOF {
			return nil
		} else if err != nil {
			return err
		}
	}
}

func main() {
	turns := grpc.WithDefaultServiceConfig(`{"loadBalancingConfig": [{"round_robin":{}}]}`)
	connection, err := grpc.Dial("dns:///"+os.Args[1], grpc.WithInsecure(), turns)
	count, wrong := strconv.Atoi(os.Args[2])
	if err != nil || wrong != nil {
		os.Exit(2)
	}
	defer connection.Close()
	for i := 0; i < count; i++ {
		if err := estimate(pb.NewCurvatureServiceClient(connection)); err != nil {
			fmt.Fprintln(os.Stderr, err)
			os.Exit(5)
		}
	}
}
