// Makes calls as one Java program: Calls SERVER CALLS. Exits with 5 if one fails.
import com.google.protobuf.ByteString;
import io.curvd.curvature.v1.*;
import io.grpc.ManagedChannel;
import io.grpc.ManagedChannelBuilder;
import io.grpc.stub.StreamObserver;
import java.nio.ByteBuffer;
import java.nio.ByteOrder;
import java.util.concurrent.CompletableFuture;
import java.util.concurrent.ExecutionException;

public final class Calls {
  private static ByteString floats(float... values) {
    ByteBuffer bytes = ByteBuffer.allocate(4 * values.length).order(ByteOrder.LITTLE_ENDIAN);
    for (float value : values) bytes.putFloat(value);
    return ByteString.copyFrom(bytes.flip());
  }

  private static void estimate(CurvatureServiceGrpc.CurvatureServiceStub stub) throws Exception {
    CompletableFuture<Void> ended = new CompletableFuture<>();
    StreamObserver<EstimateCurvatureRequest> call =
        stub.estimateCurvature(
            new StreamObserver<EstimateCurvatureResponse>() {
              @Override
              public void onNext(EstimateCurvatureResponse response) {}

              @Override
              public void onError(Throwable error) {
                ended.completeExceptionally(error);
              }

              @Override
              public void onCompleted() {
                ended.complete(null);
              }
            });
    CloudHeader header =
        CloudHeader.newBuilder()
            .setPointCount(4)
            .setScalarType(ScalarType.SCALAR_TYPE_FLOAT32)
            .setOptions(EstimatorOptions.newBuilder().setNeighborCount(4))
            .build();
    PointChunk chunk =
        PointChunk.newBuilder()
            .setPositions(floats(0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0))
            .setNormals(floats(0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1))
            .build();
    call.onNext(EstimateCurvatureRequest.newBuilder().setHeader(header).build());
    call.onNext(EstimateCurvatureRequest.newBuilder().setChunk(chunk).build());
    call.onCompleted();
    ended.get();
  }

  public static void main(String[] args) throws Exception {
    ManagedChannel channel =
        ManagedChannelBuilder.forTarget(args[0]).usePlaintext().defaultLoadBalancingPolicy("round_robin").build();
    CurvatureServiceGrpc.CurvatureServiceStub stub = CurvatureServiceGrpc.newStub(channel);
    int status = 0;
    try {
      for (int i = 0; i < Integer.parseInt(args[1]); i++) estimate(stub);
    } catch (ExecutionException error) {
      System.err.println(error.getCause());
      status = 5;
    }
    channel.shutdownNow();
    System.exit(status);
  }
}
